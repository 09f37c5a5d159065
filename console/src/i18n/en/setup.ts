export default {
  'setup.title': 'The first administrator',
  'setup.text': 'This hub has no users yet. Whoever you name here may do everything, and makes the other users.',
  'setup.no_token':
    'This hub has no users yet. Open the one-time link that it printed when it was first started; it ends in /setup# and a token.',
  'setup.password': 'Password, 10 characters or more',
  'setup.again': 'The password again',
  'setup.create': 'Create and log in',
  'setup.short': 'The password needs {n} characters or more',
  'setup.differ': 'The passwords differ',
};
