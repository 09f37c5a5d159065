export default {
  'login.title': 'Вход',
  'login.user': 'Пользователь',
  'login.password': 'Пароль',
  'login.enter': 'Войти',
  'login.wait': 'До следующей попытки {s} с',
};
